// Placeholder translation unit until the room has its first source.
