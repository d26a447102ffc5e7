"""SPICE CK kernels and the text kernels that go with them."""
