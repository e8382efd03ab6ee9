"""Films of demonstrations: frames, strips, MP4 and GIF."""
