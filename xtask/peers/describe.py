"""Prints the version of Python, the available FFTW, and the versions of the packages of the peers that are installed:
{"python": .., "fftw": {"library": .., "threads": .., "needs": [..], "source": ..}, "versions": {"Tamaas": .., ..}}.

The FFTW is that of the system, else that of pyFFTW, else null. The FFTW inside the package of Tamaas is not used, since
it has no vector code. The names can be loaded and preloaded; the libraries in "needs" must be loaded first.
"""

import ctypes
import ctypes.util
import glob
import importlib.metadata
import importlib.util
import json
import os
import platform


def loads(name):
    try:
        ctypes.CDLL(name)
    except OSError:
        return False
    return True


def of_the_system():
    candidates = filter(None, ["libfftw3.so.3", ctypes.util.find_library("fftw3")])
    library = next(filter(loads, candidates), None)
    if library is None:
        return None
    threads = filter(loads, ["libfftw3_threads.so.3", "libfftw3_omp.so.3"])
    return {"library": library, "threads": next(threads, None), "needs": [], "source": "system"}


def of_pyfftw():
    package = importlib.util.find_spec("pyfftw")
    if package is None:
        return None
    folder = os.path.join(os.path.dirname(package.submodule_search_locations[0]), "pyfftw.libs")
    libraries = glob.glob(os.path.join(folder, "libfftw3-*.so*"))
    if not libraries:
        return None
    threads = glob.glob(os.path.join(folder, "libfftw3_omp-*.so*")) + [None]
    # These libraries must be loaded first: the linker does not find them by their names.
    needs = glob.glob(os.path.join(folder, "libgomp-*.so*"))
    return {"library": libraries[0], "threads": threads[0], "needs": needs, "source": "pyFFTW"}


PACKAGES = [
    "Tamaas",
    "ContactMechanics",
    "NuMPI",
    "muGrid",
    "SurfaceTopography",
    "aspher",
    "hertzian",
    "numpy",
    "scipy",
    "h5py",
]


def versions():
    found = {}
    for package in PACKAGES:
        try:
            found[package] = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            continue
    return found


print(json.dumps({"python": platform.python_version(), "fftw": of_the_system() or of_pyfftw(), "versions": versions()}))
