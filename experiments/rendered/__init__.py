"""The mechanism of chapter 5 from images, step by step: what the dissertation asks for in its last words."""
