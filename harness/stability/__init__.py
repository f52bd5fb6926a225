"""Numerical stability at the extremes: how far each tracer can be pushed, counted in rays."""
