"""Charts described once as plain data (`chart`), drawn for the page (`web`), paper (`paper`) and the terminal (`text`)."""
