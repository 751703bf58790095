"""The mechanism of chapter 5 from images, turn by turn: what the dissertation asks for in its last words."""
