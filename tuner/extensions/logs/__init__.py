"""Flight logs as one typed record, whatever program wrote them."""
