"""What holds for all tests and for the examples in docstrings."""

import gc
import os
import sys
from collections.abc import Iterator
from pathlib import Path

import hypothesis
import pytest

# For this process and for those that tests start; JAX reads them when it is first imported.
_CACHE = Path(__file__).parent / ".cache" / "xla"
os.environ.setdefault("JAX_COMPILATION_CACHE_DIR", str(_CACHE))
os.environ.setdefault("JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS", "0.1")
os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")  # kernels read back from the cache are not announced as errors
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # processes share the cores already, and threads that wait burn them
os.environ.setdefault("JAX_NUMPY_RANK_PROMOTION", "raise")  # broadcasting over axes is written out, never happens

# The same examples in every run, however slow the machine.
hypothesis.settings.register_profile("jaxtex", derandomize=True, deadline=None, database=None, max_examples=15)
hypothesis.settings.load_profile("jaxtex")


# Each piece of compiled code takes some of a process's memory mappings, of which Linux allows 65530; a compiler that
# gets no more of them crashes.
_MAPPINGS = 30_000


@pytest.fixture(autouse=True, scope="module")
def _compiled_code_is_let_go() -> Iterator[None]:
    yield
    mappings = Path("/proc/self/maps")
    if "jax" in sys.modules and mappings.exists() and mappings.read_bytes().count(b"\n") > _MAPPINGS:
        sys.modules["jax"].clear_caches()
        gc.collect()


@pytest.fixture(autouse=True)
def _examples_write_to_a_folder_of_their_own(request: pytest.FixtureRequest) -> None:
    if isinstance(request.node, pytest.DoctestItem):
        request.getfixturevalue("monkeypatch").chdir(request.getfixturevalue("tmp_path"))
