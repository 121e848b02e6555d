"""The tests of poisson-cli; a package, so that its modules can share oracles, regions and photographs."""
