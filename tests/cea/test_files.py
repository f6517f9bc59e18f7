"""Files and folders are written whole or not at all, on a full disk and in a killed process too."""

import resource
import signal
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path
from time import sleep

import pytest

from cea.errors import WriteError
from cea.files import folder_whole, write_whole


@contextmanager
def full_disk(size):
    """Files cannot grow beyond a size (bytes), as on a disk with no more room."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def names(folder):
    return sorted(each.name for each in folder.iterdir())


def test_a_full_disk_leaves_the_old_file(tmp_path):
    file = write_whole(b"old", tmp_path / "sub" / "r.json")
    with full_disk(1000), pytest.raises(WriteError, match=r"r.json cannot be written: File too l"):
        write_whole(b"x" * 5000, file)
    assert file.read_bytes() == b"old"
    assert names(file.parent) == ["r.json"]


def test_a_folder_takes_the_place_of_another_whole(tmp_path):
    folder = tmp_path / "modes"
    for content in (b"1", b"2"):
        with folder_whole(folder) as part:
            write_whole(content, part / f"{content.decode()}.vtu")
    assert names(folder) == ["2.vtu"]
    assert names(tmp_path) == ["modes"]


def test_a_folder_stays_as_it_was_where_filling_it_fails(tmp_path):
    folder = tmp_path / "modes"
    with folder_whole(folder) as part:
        write_whole(b"1", part / "1.vtu")

    def fill():
        with folder_whole(folder) as part:
            write_whole(b"new", part / "1.vtu")
            write_whole(b"x" * 5000, part / "2.vtu")

    with full_disk(1000), pytest.raises(WriteError):
        fill()
    assert (folder / "1.vtu").read_bytes() == b"1"
    assert names(tmp_path) == ["modes"]


WRITER = """
import sys
from contextlib import contextmanager
from pathlib import Path
from cea.files import write_whole
out = Path(sys.argv[1])
write_whole(b"0" * 10**6, out)
print("begun", flush=True)
for i in range(10**6):
    write_whole(str(i % 10).encode() * 10**6, out)
"""


def test_a_killed_process_leaves_a_whole_file(tmp_path):
    file = tmp_path / "r.bin"
    for delay in (0.01, 0.03, 0.07):
        process = subprocess.Popen(
            [sys.executable, "-c", WRITER, str(file)],
            stdout=subprocess.PIPE,
            cwd=Path(__file__).parents[2],
        )
        process.stdout.readline()
        sleep(delay)
        process.send_signal(signal.SIGKILL)
        process.wait()
        process.stdout.close()
        content = file.read_bytes()
        assert len(content) == 10**6
        assert len(set(content)) == 1
