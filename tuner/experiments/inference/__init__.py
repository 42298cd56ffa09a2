"""Inference: which values of what a paper leaves open reproduce its published cells, and which cells nothing reproduces."""
