"""The engine: a component bus made of component buses; applications and connections are not known here."""
