"""Valid and damaged files in every role; the long version is ``python -m tests.corpus``."""

import itertools

import pytest

from tests import corpus
from tests.kinds import KINDS
from tests.mutations import mutated

DAMAGED = [
    "PNG, RGB, 8 bits",
    "PNG, RGB with alpha, 16 bits",
    "PNG, palette with transparent colours",
    "JPEG, RGB",
    "JPEG, RGB, progressive",
    "TIFF, RGB, 8 bits, LZW",
    "TIFF, RGB, 16 bits, tiles, Deflate with predictor",
    "TIFF, RGB, floating point",
    "TIFF, RGB, 8 bits, BigTIFF, big-endian",
    "BMP, RGB",
    "WebP, RGB with alpha, without loss",
    "GIF",
    "PGM, in figures",
    "PPM, 16 bits",
    "PFM, RGB",
    "Radiance HDR, in runs",
]


@pytest.fixture(autouse=True)
def prepared(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    corpus.prepare()


@pytest.mark.parametrize("name", KINDS)
def test_whole_files_are_read_in_every_role(name):
    data = KINDS[name]().data
    for role in corpus.ROLES:
        outcome = corpus.attempt(data, role)
        assert corpus.complaint(outcome) is None
        # Random opacity and colours on grey have good reasons to be refused.
        reasons = (
            "transparent in places",
            "convert one of them",
            "is converted",
            "the selection is empty",
            "made of red, green and blue",
        )
        assert outcome.code == 0 or any(reason in outcome.err for reason in reasons), outcome.err


@pytest.mark.parametrize("name", DAMAGED)
def test_damaged_files_are_read_or_refused(name):
    data = KINDS[name]().data
    roles = itertools.cycle(corpus.ROLES)
    refused = 0
    mutations = [(f"mutation {seed}", mutated(name, data, seed)) for seed in range(100, 125)]
    for damage, file in [*corpus.truncated(data), *corpus.flipped(data, 25), *mutations]:
        role = next(roles)
        outcome = corpus.attempt(file, role)
        assert corpus.complaint(outcome) is None, (damage, role)
        refused += outcome.code == 3
    assert refused > 15


@pytest.mark.parametrize("name", corpus.BOMBS)
def test_header_bombs_are_refused_at_once(name):
    for role in ("picture of fill", "mask of clone"):
        outcome = corpus.attempt(corpus.BOMBS[name], role)
        assert (outcome.code, corpus.complaint(outcome)) == (3, None)
