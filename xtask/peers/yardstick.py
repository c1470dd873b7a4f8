"""Measures the yardstick: wall time of one forward and one inverse real transform of n x n doubles by FFTW, measured
plans.

    yardstick.py '{"sizes": [N, ...], "threads": [T, ...], "fftw": {...}, "wisdom": FILE, "seconds": S}'

Prints {"version": .., "pairs": [{"n": .., "threads": .., "seconds": [one mean per batch], "share": ..}, ...]}. Plans
are kept in FILE, since measuring them takes long. A share below 1 on one thread means that other processes were
running.
"""

import ctypes
import json
import os
import sys
import time

MEASURE = 0


class Fftw:
    def __init__(self, names):
        self.needs = [ctypes.CDLL(name) for name in names["needs"]]
        self.functions = ctypes.CDLL(names["library"])
        self.parallel = ctypes.CDLL(names["threads"]) if names["threads"] else None
        if self.parallel:
            self.parallel.fftw_init_threads()
        for function in ("fftw_malloc", "fftw_plan_dft_r2c_2d", "fftw_plan_dft_c2r_2d"):
            getattr(self.functions, function).restype = ctypes.c_void_p
        self.functions.fftw_malloc.argtypes = [ctypes.c_size_t]
        for function in ("fftw_free", "fftw_destroy_plan", "fftw_execute"):
            getattr(self.functions, function).argtypes = [ctypes.c_void_p]
            getattr(self.functions, function).restype = None
        self.version = ctypes.string_at(ctypes.addressof(ctypes.c_char.in_dll(self.functions, "fftw_version"))).decode()

    def pair(self, n, threads, budget):
        """Returns the mean times of a pair in batches over `budget` seconds, and processor time over wall time and
        threads.
        """
        if self.parallel:
            self.parallel.fftw_plan_with_nthreads(threads)
        real, spectrum = self.functions.fftw_malloc(8 * n * n), self.functions.fftw_malloc(16 * n * (n // 2 + 1))
        a, b = ctypes.c_void_p(real), ctypes.c_void_p(spectrum)
        forward = self.functions.fftw_plan_dft_r2c_2d(n, n, a, b, ctypes.c_uint(MEASURE))
        inverse = self.functions.fftw_plan_dft_c2r_2d(n, n, b, a, ctypes.c_uint(MEASURE))
        ctypes.memset(real, 0, 8 * n * n)
        execute = self.functions.fftw_execute

        def batch(count):
            started = time.perf_counter()
            for _ in range(count):
                execute(forward)
                execute(inverse)
            return (time.perf_counter() - started) / count

        batch(2)
        count = max(1, int(budget / 10 / batch(3)))
        wall, cpu = time.perf_counter(), time.process_time()
        seconds = [batch(count) for _ in range(10)]
        share = (time.process_time() - cpu) / ((time.perf_counter() - wall) * threads)
        self.functions.fftw_destroy_plan(forward)
        self.functions.fftw_destroy_plan(inverse)
        self.functions.fftw_free(real)
        self.functions.fftw_free(spectrum)
        return seconds, share


def main():
    task = json.loads(sys.argv[1])
    fftw = Fftw(task["fftw"])
    wisdom = task["wisdom"].encode()
    if os.path.exists(wisdom):
        fftw.functions.fftw_import_wisdom_from_filename(wisdom)
    pairs = []
    for n in task["sizes"]:
        for threads in task["threads"]:
            if threads > 1 and not fftw.parallel:
                sys.exit("this FFTW has no threads")
            seconds, share = fftw.pair(n, threads, task["seconds"])
            pairs.append({"n": n, "threads": threads, "seconds": seconds, "share": share})
    fftw.functions.fftw_export_wisdom_to_filename(wisdom)
    print(json.dumps({"version": fftw.version, "pairs": pairs}))


main()
