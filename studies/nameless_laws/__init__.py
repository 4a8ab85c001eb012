"""Laws that are in no library, and how what springpot says of them is counted."""
