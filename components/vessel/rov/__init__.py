"""A remotely operated vehicle under water."""
