"""Compilation, caching and calls of kernels; threads; atomic files.

From a kernel's source to a call, for `compiled.invariants(tensors, moments, ...)`:

1. `compiled.Kernel` looks at the arguments: their kinds ("d3": C-ordered doubles, three dimensions)
   and the kernel's name are a `signature.Signature`, and each signature has machine code of its own.
2. `prebuilt` has it where `python -m attitude.runtime.build` built a library ahead (container images).
3. `kernel_cache` has it on disk where this machine compiled it before: the file's name ends with a
   digest of the kernel's sources, so that code of an older source is never loaded.
4. Else `compiler`, in a process of its own, has numba translate the kernel to LLVM's language and
   LLVM make an object file of it, for this processor; `numba_internals` makes that faster.
5. The object file is loaded by llvmlite (a library by the system), and called through ctypes as
   numba would call it.  Nothing of numba is imported by a process that only calls.
"""
