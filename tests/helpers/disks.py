"""A disk that is full: files cannot grow beyond a size."""

import resource
from contextlib import contextmanager


@contextmanager
def full_disk(size):
    """Files cannot grow beyond a size (bytes), as on a disk with no more room."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
