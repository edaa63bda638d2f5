"""What a person says to one robot: lines of FIPA ACL, and sentences of a restricted language (SRA, speech acts)."""
