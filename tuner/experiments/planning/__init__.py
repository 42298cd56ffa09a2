"""What a run will take and how sure its figures will be, from a few candidates that are flown first."""
