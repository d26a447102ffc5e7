"""The effects a scene may name, one module each."""
