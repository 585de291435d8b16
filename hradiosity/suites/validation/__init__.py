"""The program against published cases, closed forms and a catalogue of form factors; `hradiosity validate`."""
