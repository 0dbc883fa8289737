"""The seeds' optimisation models as tested parts: encodings, penalties, demand model, decoding and replay."""
