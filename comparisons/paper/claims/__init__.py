"""The paper's claims, and what decides each of them."""
