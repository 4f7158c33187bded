"""Options that verbs share."""

from rtbow.base.arrays import Steps
from rtbow.cli import options


def test_a_pipe_is_told_what_is_built_if_that_is_slow(monkeypatch, capsys):
    timers = []

    class Timer:
        daemon = False

        def __init__(self, after_s, call, args, kwargs):
            self.fire, self.cancelled = lambda: call(*args, **kwargs), False
            timers.append(self)

        def start(self):
            pass

        def cancel(self):
            self.cancelled = True

    monkeypatch.setattr(options.threading, "Timer", Timer)
    progress = options.progress_bar("building the table", False)
    for _ in progress(Steps(1, "a mixture")):
        timers[0].fire()
    assert capsys.readouterr().err == "building the table: a mixture\n"
    assert timers[0].cancelled
    # Neither what is drawn nor what was asked to be quiet.
    assert list(options.progress_bar("rendering", False)(range(2))) == [0, 1]
    assert list(options.progress_bar("building the table", True)(Steps(2, "it"))) == [0, 1]
    assert len(timers) == 1
