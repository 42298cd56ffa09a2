"""Inference: which values of what a paper leaves open reproduce its published cells, and which cells nothing reproduces."""

from tuner.study.inference import Cell, Inference, Unknown
from tuner.study.inference_reading import is_inference, load_inference

__all__ = ["Cell", "Inference", "Unknown", "is_inference", "load_inference"]
