"""Inference: which values of what a paper leaves open reproduce its published cells, and which cells nothing reproduces."""

from tuner.inference.inference import Cell, Inference, Unknown
from tuner.inference.reading import is_inference, load_inference

__all__ = ["Cell", "Inference", "Unknown", "is_inference", "load_inference"]
