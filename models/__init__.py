"""Everything that is learned."""
