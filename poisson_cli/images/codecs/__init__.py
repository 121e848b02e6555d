"""Decoders and encoders, one module each, imported when a file or an output asks for it.

Each has ``decode(data, name, form, *, indices) -> Decoded``, which may raise anything (`reading` turns it into one
error of ours), and ``encode(picture, form, quality) -> bytes`` for a picture that the format can hold.
"""
