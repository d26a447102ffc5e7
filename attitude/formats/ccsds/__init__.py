"""CCSDS attitude ephemeris message (AEM), 504.0-B-2: KVN and XML."""
