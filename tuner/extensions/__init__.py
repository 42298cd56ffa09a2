"""Extensions: one capability a folder, each with the record of all that it adds to the tool."""
