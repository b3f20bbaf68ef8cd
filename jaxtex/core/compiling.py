"""What is asked of XLA where its defaults do not serve."""

SAME_EVERY_TIME = {"xla_cpu_multi_thread_eigen": False}
"""Compiler options of `jax.jit` for results that are the same bit for bit whenever they are computed.

On the CPU, how a Fourier transform or a matrix product is shared out among threads depends on what else is being run,
and its last bits on how it is shared out. Of the sizes met here, one thread is not slower.
"""
