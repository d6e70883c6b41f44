"""How much of what varies matters: variance indices over properties and over open choices."""
