"""The memory of this process."""

import resource


def peak_bytes():
    """Largest resident memory so far. On Linux, ru_maxrss is at least the memory of the process that started this
    one.
    """
    try:
        with open("/proc/self/status") as status:
            return next(1024 * int(line.split()[1]) for line in status if line.startswith("VmHWM:"))
    except (OSError, StopIteration):
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
