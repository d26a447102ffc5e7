"""The closed form of gyrostats: bodies with rotors of constant momentum and no torque."""
