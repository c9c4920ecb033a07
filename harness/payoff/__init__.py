"""What rewards pay what is there already: scripted movements of an arm, and the steps of data sets."""
