"""Measurements that need what not every machine has: a graphics card, other simulators."""
