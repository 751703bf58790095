"""The mechanism of chapter 5 from pictures, turn by turn: what the dissertation asks of a real robot in its last words."""
