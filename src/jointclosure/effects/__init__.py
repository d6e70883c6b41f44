"""What each effect adds and costs, and which ones a case calls for."""
