"""Images from a folder or a video file."""
