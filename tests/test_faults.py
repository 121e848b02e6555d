"""Nothing is lost when the disk is full or a signal comes; the long version is ``python -m tests.faults``."""

import signal

import numpy as np
import pytest

from tests import faults


@pytest.fixture
def folder(tmp_path):
    faults.prepare(tmp_path)
    return tmp_path


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_a_signal_at_any_time_loses_nothing(folder, number):
    verdicts = faults.signalled(folder, number, 6, np.random.default_rng(number))
    assert not [said for said in verdicts if said.startswith("LOST")], verdicts


def test_too_little_room_loses_nothing(folder):
    assert faults.limited(folder, 4) == {"kept": 4}
