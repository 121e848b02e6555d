"""Long work on another thread, so that a signal is heard meanwhile."""

import os
import signal
import threading
import time

import pytest

from poisson_cli import answering


def test_the_same_thread_works_again():
    first, second = (answering.do(threading.current_thread) for _ in range(2))
    assert first is second is not threading.main_thread()


def test_what_the_work_raises_is_raised_and_more_work_is_done():
    with pytest.raises(ZeroDivisionError):
        answering.do(lambda: 1 // 0)
    assert answering.do(lambda: 7) == 7


def test_interrupted_work_is_abandoned_and_does_not_hold_up_what_follows():
    ended = threading.Event()

    def work() -> threading.Thread:
        os.kill(os.getpid(), signal.SIGINT)
        ended.wait(30)
        return threading.current_thread()

    usual = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        start = time.monotonic()
        with pytest.raises(KeyboardInterrupt):
            answering.do(work)
        assert answering.do(lambda: 7) == 7
        assert time.monotonic() - start < 10
    finally:
        ended.set()
        signal.signal(signal.SIGINT, usual)


def test_where_nobody_waits_for_an_answer_nothing_is_handed_over(monkeypatch):
    monkeypatch.setattr(answering, "_patient", False)  # to be what it was when the test is over
    answering.be_patient()
    assert answering.do(threading.current_thread) is threading.main_thread()


def test_work_within_work_is_done_at_once():
    outer, inner = answering.do(lambda: (threading.current_thread(), answering.do(threading.current_thread)))
    assert outer is inner
