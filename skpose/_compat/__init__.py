"""What is taken from private parts of other libraries, one file for each: the places to mend when these change."""
