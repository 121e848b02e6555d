"""What `poisson` costs beside other tools, with every answer checked.  Run `python -m benchmarks --help`.

Nothing here is installed with the package.  Importing this package loads nothing: `__main__` must set the
thread limits in the environment before numpy is imported for the first time.
"""
