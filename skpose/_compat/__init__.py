"""Private parts of other libraries that skpose uses, a file for each library: what to change when these change."""
