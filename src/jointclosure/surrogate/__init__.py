"""How far a bearing-area law tells the closure of a first loading."""
