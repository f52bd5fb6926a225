"""The benchmark of rays: the same rays, from one file, through every tracer."""
