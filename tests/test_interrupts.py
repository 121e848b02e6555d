"""Signals end a run until its output takes its name, and one that comes twice ends it once."""

import signal
import sys

import pytest

from poisson_cli import interrupts

NUMBERS = {
    signal.SIGINT: KeyboardInterrupt,
    signal.SIGTERM: interrupts.Terminated,
    signal.SIGHUP: interrupts.HungUp,
}


@pytest.fixture(autouse=True)
def usual_handlers():
    usual = {number: signal.getsignal(number) for number in NUMBERS}
    for number in NUMBERS:
        signal.signal(number, signal.SIG_DFL)
    interrupts.finishing.clear()
    yield
    interrupts.finishing.clear()
    interrupts.listen()  # forgets what was heard
    for number, handler in usual.items():
        signal.signal(number, handler)


@pytest.mark.parametrize("number", NUMBERS)
def test_a_signal_is_an_exception_and_its_echo_is_none(number):
    interrupts.listen()
    with pytest.raises(NUMBERS[number]):
        signal.raise_signal(number)
    signal.raise_signal(number)


@pytest.mark.parametrize("number", NUMBERS)
def test_one_that_comes_in_a_destructor_is_not_lost(number, monkeypatch):
    class Fragile:
        def __init__(self, fails):
            self.fails = fails

        def __del__(self):
            self.fails()

    told = []
    monkeypatch.setattr(sys, "unraisablehook", lambda dropped: told.append(dropped.exc_type))
    interrupts.listen()
    interrupts.check()
    with interrupts.hushed():
        for fails in (lambda: signal.raise_signal(number), lambda: {}[0]):
            fragile = Fragile(fails)
            del fragile  # Python drops the exception
    assert told == [KeyError]
    with pytest.raises(NUMBERS[number]):
        interrupts.check()
    interrupts.listen()
    interrupts.check()


@pytest.mark.parametrize("number", NUMBERS)
def test_it_comes_too_late_when_the_output_takes_its_name(number):
    interrupts.listen()
    interrupts.finishing.set()
    signal.raise_signal(number)


def test_a_process_that_was_started_deaf_stays_so():
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    interrupts.listen()
    signal.raise_signal(signal.SIGINT)
    assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN


def test_a_run_is_not_stopped_any_more_once_its_output_is_there(folder, poisson):
    assert poisson("fill", "grey.png", "--rect", "3,3,9,9", "-o", "out.xyz").code == 4
    assert not interrupts.finishing.is_set()
    assert poisson("fill", "grey.png", "--rect", "3,3,9,9", "-o", "out.png").code == 0
    assert interrupts.finishing.is_set()
