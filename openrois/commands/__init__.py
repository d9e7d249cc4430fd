"""Commands between acceptance and end: their ids, quota, sequence and STOP."""
