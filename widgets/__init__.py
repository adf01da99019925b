"""What is seen and touched: takes engine values, says what the user wants, changes nothing by itself."""
