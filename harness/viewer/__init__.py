"""The viewer of images with a high dynamic range: a part of the report that needs no network."""
