"""What a rig did: a log of a day split into rotating, sliding, rocking, connections, tripping and the rest."""
