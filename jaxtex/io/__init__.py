"""The outer boundary: files of images, written and read whole or not at all."""
