"""The subcommands, one module each; the module's name is the command's name, its ``command`` the command."""
