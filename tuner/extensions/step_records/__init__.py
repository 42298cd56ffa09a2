"""Records of commands that go on where they ended."""
