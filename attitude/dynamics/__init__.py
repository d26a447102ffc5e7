"""What happens to a body: numbers in, attitudes in time out.  Knows units no more than kernels do, and no documents."""
