"""Sections 3 and 4 of the paper, each tool a few lines over one pipeline.

Pictures are (H, W) or (H, W, C) arrays of uint8, uint16, float32 or float64; floats have full scale 1.  The result
has the destination's shape and dtype; outside the selection it is the destination, bit for bit.  No argument is
modified.

They return an `Edit`: the picture and a report.  `poisson_cli.clone` and so on are the same functions
and return the picture alone.
"""
