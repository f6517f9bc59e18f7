"""Peak memory of a process that a test starts.

The resource usage of a process begins with that of the one it came from; its own peak does not.
"""

PEAK = """
def peak():
    with open("/proc/self/status") as lines:
        return 1024 * next(int(line.split()[1]) for line in lines if line.startswith("VmHWM:"))
"""
"""Defines ``peak()``, the largest resident memory of the process so far (bytes)."""
