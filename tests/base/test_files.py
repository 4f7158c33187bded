"""Output files: whole or not at all, with messages that say what to do."""

import errno
import os
import resource
import signal
import stat
import subprocess
import sys
import threading

import pytest

from command_line import names
from rtbow.base import files
from rtbow.base.errors import InputError
from rtbow.base.files import check_writable, replacing, write_atomic

SUFFIXES = (".exr", ".png")


def test_new_file_has_content_and_permissions_of_umask(tmp_path):
    for umask in (0o022, 0o077, 0o002):
        before = os.umask(umask)
        try:
            path = tmp_path / f"{umask:o}.exr"
            write_atomic(path, b"content")
        finally:
            os.umask(before)
        assert path.read_bytes() == b"content"
        assert stat.S_IMODE(path.stat().st_mode) == 0o666 & ~umask
    assert not [name for name in names(tmp_path) if name.endswith(".tmp")]


def test_existing_file_is_replaced_and_keeps_its_permissions(tmp_path):
    path = tmp_path / "frame.exr"
    path.write_bytes(b"old and longer")
    path.chmod(0o640)
    write_atomic(str(path), b"new")
    assert path.read_bytes() == b"new"
    assert stat.S_IMODE(path.stat().st_mode) == 0o640


def test_reader_of_the_old_file_keeps_it_whole(tmp_path):
    path = tmp_path / "frame.exr"
    path.write_bytes(b"old")
    with path.open("rb") as reader:
        write_atomic(path, b"new")
        assert reader.read() == b"old"


def test_symbolic_link_stays_and_its_target_is_replaced(tmp_path):
    (tmp_path / "far").mkdir()
    target = tmp_path / "far" / "target.exr"
    link = tmp_path / "link.exr"
    link.symlink_to(target)
    for content in (b"through a dangling link", b"again"):
        write_atomic(link, content)
        assert link.is_symlink()
        assert target.read_bytes() == content
    assert names(tmp_path) == ["far", "link.exr"]
    assert names(tmp_path / "far") == ["target.exr"]


def test_longest_possible_name(tmp_path):
    path = tmp_path / ("n" * 251 + ".exr")
    check_writable(path, SUFFIXES)
    write_atomic(path, b"content")
    assert path.read_bytes() == b"content"
    with pytest.raises(InputError, match="name too long; choose a shorter name"):
        write_atomic(tmp_path / ("n" * 252 + ".exr"), b"content")


@pytest.mark.parametrize("call", ["write", "fsync", "replace", "close"])
@pytest.mark.parametrize("error", [OSError(errno.ENOSPC, "full"), KeyboardInterrupt()])
def test_failure_at_any_step_leaves_the_old_file_alone(tmp_path, monkeypatch, call, error):
    path = tmp_path / "frame.exr"
    path.write_bytes(b"old")
    really_close = os.close

    def fail(*args, **kwargs):
        if call == "close":
            really_close(*args)
        raise error

    with monkeypatch.context() as patch:
        patch.setattr(files.os, call, fail)
        expected = InputError if isinstance(error, OSError) else KeyboardInterrupt
        with pytest.raises(expected):
            write_atomic(path, b"new content")
    assert path.read_bytes() == b"old"
    assert names(tmp_path) == ["frame.exr"]


def test_write_that_takes_only_a_part_is_continued(tmp_path, monkeypatch):
    write = os.write
    monkeypatch.setattr(files.os, "write", lambda fd, data: write(fd, data[:3]))
    write_atomic(tmp_path / "frame.exr", b"ten bytes!")
    assert (tmp_path / "frame.exr").read_bytes() == b"ten bytes!"


def test_limit_on_file_size_is_explained_and_leaves_nothing(tmp_path):
    path = tmp_path / "frame.exr"
    path.write_bytes(b"old")
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, hard))
    try:
        with pytest.raises(InputError, match=r"frame\.exr: cannot be written: .*ulimit -f"):
            write_atomic(path, bytes(5000))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        signal.signal(signal.SIGXFSZ, handler)
    assert path.read_bytes() == b"old"
    assert names(tmp_path) == ["frame.exr"]


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="only Linux has /dev/full")
def test_full_device_is_explained(tmp_path):
    link = tmp_path / "full.exr"
    link.symlink_to("/dev/full")
    check_writable(link, SUFFIXES)
    with pytest.raises(InputError, match=r"full\.exr: cannot be written: .*free some space"):
        write_atomic(link, b"content")
    assert link.is_symlink()
    assert stat.S_ISCHR(os.stat("/dev/full").st_mode)


def test_pipe_is_written_to_and_stays_a_pipe(tmp_path):
    path = tmp_path / "pipe.exr"
    os.mkfifo(path)
    check_writable(path, SUFFIXES)
    got = []
    reader = threading.Thread(target=lambda: got.append(path.read_bytes()))
    reader.start()
    write_atomic(path, b"content" * 50_000)
    reader.join()
    assert got == [b"content" * 50_000]
    assert stat.S_ISFIFO(path.stat().st_mode)


def test_own_output_is_continued_and_not_replaced(tmp_path):
    link = tmp_path / "stdout.exr"
    link.symlink_to("/dev/stdout")
    log = tmp_path / "log"
    log.write_bytes(b"earlier lines\n")
    program = (
        "import sys; from rtbow.base.files import write_atomic; write_atomic(sys.argv[1], b'frame')"
    )
    with log.open("ab") as stdout:
        subprocess.run([sys.executable, "-c", program, str(link)], stdout=stdout, check=True)
    assert log.read_bytes() == b"earlier lines\nframe"
    piped = subprocess.run(
        [sys.executable, "-c", program, str(link)], stdout=subprocess.PIPE, check=True
    )
    assert piped.stdout == b"frame"


def test_killed_process_leaves_the_old_file_whole(tmp_path):
    path = tmp_path / "frame.exr"
    path.write_bytes(b"old")
    program = (
        "import os, signal, sys\n"
        "from rtbow.base import files\n"
        "files.os.fsync = lambda fd: os.kill(os.getpid(), signal.SIGKILL)\n"
        "files.write_atomic(sys.argv[1], b'new')\n"
    )
    done = subprocess.run([sys.executable, "-c", program, str(path)])
    assert done.returncode == -signal.SIGKILL
    assert path.read_bytes() == b"old"


def test_check_accepts_what_can_be_written_and_leaves_nothing(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "old.PNG").write_bytes(b"old")
    for path in ("new.exr", "./new.png", "old.PNG", tmp_path / "NEW.Exr"):
        check_writable(path, SUFFIXES)
    assert names(tmp_path) == ["old.PNG"]
    assert (tmp_path / "old.PNG").read_bytes() == b"old"


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("frame.jpg", r"frame\.jpg: suffix \.jpg is not known; must be \.exr or \.png; .*frame\.e"),
        ("frame", r"frame: the name has no suffix; must be \.exr or \.png"),
        ("", r"the name has no suffix"),
        ("no/such/x.exr", r"no/such/x\.exr: there is no folder no; create it .*mkdir -p no/such$"),
        ("a b/x.exr", r"there is no folder a b; create it with: mkdir -p 'a b'"),
        ("here/no/x.exr", r"there is no folder here/no; create it with: mkdir -p here/no"),
        ("file/x.exr", r"file/x\.exr: file is a file; must be a folder"),
        ("dir.exr", r"dir\.exr: is a folder; must be a file"),
        ("loop.exr", r"loop\.exr: cannot be written: .*loop"),
        ("nul\0.exr", r"not a file name"),
    ],
)
def test_check_says_what_is_wrong_and_what_to_do(tmp_path, monkeypatch, path, message):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "here").mkdir()
    (tmp_path / "dir.exr").mkdir()
    (tmp_path / "file").touch()
    (tmp_path / "loop.exr").symlink_to("loop.exr")
    before = names(tmp_path)
    with pytest.raises(InputError, match=message):
        check_writable(path, SUFFIXES)
    if path.endswith(".exr"):
        with pytest.raises(InputError, match=message):
            write_atomic(path, b"content")
    assert names(tmp_path) == before


def test_dangling_link_into_a_missing_folder_names_that_folder(tmp_path):
    link = tmp_path / "link.exr"
    link.symlink_to(tmp_path / "gone" / "frame.exr")
    with pytest.raises(InputError, match=r"there is no folder .*gone; create it with: mkdir -p"):
        check_writable(link, SUFFIXES)


def run_without_rights(code):
    """Run Python code where permission bits count: as nobody, if the tests run as root."""

    def become_nobody():
        if os.geteuid() == 0:
            os.setgid(65534)
            os.setuid(65534)

    # Modules are loaded before the rights go: nobody may not see the checkout.
    import rtbow.base.errors

    child = os.fork()
    if child == 0:
        status = 1
        try:
            become_nobody()
            code()
            status = 0
        except rtbow.base.errors.InputError as error:
            os.write(2, f"InputError: {error}\n".encode())
            status = 2
        except BaseException as error:
            os.write(2, f"{error!r}\n".encode())
        finally:
            os._exit(status)
    _, status = os.waitpid(child, 0)
    return os.waitstatus_to_exitcode(status)


@pytest.fixture
def open_folder():
    """Make a folder that any user can reach; the one of tmp_path is closed to others."""
    import shutil
    import tempfile
    from pathlib import Path

    folder = Path(tempfile.mkdtemp(prefix="rtbow-test-"))
    folder.chmod(0o755)
    yield folder
    shutil.rmtree(folder)


def test_folder_without_rights(open_folder, capfd):
    closed = open_folder / "closed"
    closed.mkdir()
    (closed / "old.exr").write_bytes(b"old")
    closed.chmod(0o555)
    for name in ("new.exr", "old.exr"):
        path = closed / name
        for call in (
            lambda path=path: check_writable(path, SUFFIXES),
            lambda path=path: write_atomic(path, b"content"),
        ):
            assert run_without_rights(call) == 2
            message = capfd.readouterr().err
            assert f"InputError: {path}: " in message
            assert "may write to" in message or "write-protected" in message
    closed.chmod(0o755)
    assert names(closed) == ["old.exr"]
    assert (closed / "old.exr").read_bytes() == b"old"


def test_write_protected_file_is_respected(open_folder, capfd):
    folder = open_folder / "own"
    folder.mkdir()
    folder.chmod(0o777)
    path = folder / "kept.exr"
    path.write_bytes(b"kept")
    path.chmod(0o444)
    assert run_without_rights(lambda: check_writable(path, SUFFIXES)) == 2
    assert "kept.exr: is write-protected" in capfd.readouterr().err
    assert run_without_rights(lambda: write_atomic(path, b"new")) == 2
    assert path.read_bytes() == b"kept"
    assert names(folder) == ["kept.exr"]


def fail_halfway(path, error):
    path.write_bytes(b"half")
    raise error


class TestReplacing:
    """A library that writes to a name, such as a film's."""

    def test_a_new_file_and_one_that_stood_there(self, tmp_path):
        path = tmp_path / "film.mp4"
        for content in (b"first", b"second, longer"):
            with replacing(path) as temporary:
                assert temporary.parent == tmp_path
                temporary.write_bytes(content)
                assert not path.exists() or path.read_bytes() == b"first"
            assert path.read_bytes() == content
            path.chmod(0o640)
        assert names(tmp_path) == ["film.mp4"]
        assert stat.S_IMODE(path.stat().st_mode) == 0o640

    @pytest.mark.parametrize("error", [KeyboardInterrupt, ValueError, OSError])
    def test_what_stood_there_stays_after_any_failure(self, tmp_path, error):
        path = tmp_path / "film.mp4"
        path.write_bytes(b"old")
        with pytest.raises(error), replacing(path) as temporary:
            fail_halfway(temporary, error)
        assert path.read_bytes() == b"old"
        assert names(tmp_path) == ["film.mp4"]

    @pytest.mark.parametrize("step", ["fsync", "replace"])
    def test_a_failure_at_the_end_is_explained(self, tmp_path, monkeypatch, step):
        def fail(*_):
            raise OSError(errno.ENOSPC, "full")

        path = tmp_path / "film.mp4"
        path.write_bytes(b"old")
        with (
            pytest.raises(InputError, match=r"film.mp4: cannot be written: .*; free some space"),
            replacing(path),
        ):
            monkeypatch.setattr(files.os, step, fail)
        monkeypatch.undo()
        assert path.read_bytes() == b"old"
        assert names(tmp_path) == ["film.mp4"]

    def test_a_link_keeps_leading_to_its_file(self, tmp_path):
        (tmp_path / "far").mkdir()
        (tmp_path / "link.mp4").symlink_to(tmp_path / "far" / "film.mp4")
        with replacing(tmp_path / "link.mp4") as temporary:
            temporary.write_bytes(b"new")
        assert (tmp_path / "link.mp4").is_symlink()
        assert names(tmp_path / "far") == ["film.mp4"]

    def test_a_device_is_written_to_and_stays(self, tmp_path):
        (tmp_path / "null.mp4").symlink_to(os.devnull)
        with replacing(tmp_path / "null.mp4") as temporary:
            assert temporary.parent != tmp_path
            temporary.write_bytes(b"new")
        assert not temporary.exists()
        assert stat.S_ISCHR(os.stat(os.devnull).st_mode)

    def test_a_folder_that_is_not_there(self, tmp_path):
        with (
            pytest.raises(InputError, match="there is no folder"),
            replacing(tmp_path / "no" / "a"),
        ):
            pass
